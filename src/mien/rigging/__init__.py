"""Rig transfer: a rig made for one face, put on any other."""
