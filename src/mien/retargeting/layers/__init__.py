"""Emotion, speech and blink as layers (Kholgade, Matthews, Sheikh 2011)."""

from mien.retargeting.layers.compose import composed, layer_clip, split_clip, split_rig
from mien.retargeting.layers.method import Layers
from mien.retargeting.layers.model import Layer, LayeredFace, regions_of_groups, shared
from mien.retargeting.layers.retargeter import LayeredRetargeter
from mien.retargeting.layers.sources import Pick, picked_layers, rig_face, table_of

__all__ = [
    "Layer",
    "LayeredFace",
    "LayeredRetargeter",
    "Layers",
    "Pick",
    "composed",
    "layer_clip",
    "picked_layers",
    "regions_of_groups",
    "rig_face",
    "shared",
    "split_clip",
    "split_rig",
    "table_of",
]
