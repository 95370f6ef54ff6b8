"""Benchmarks of rig transfer."""
