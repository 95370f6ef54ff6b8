"""What the modellers of heads share: blended solids, and a half head that is mirrored."""
