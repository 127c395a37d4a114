"""Clamp and pipe FMUs: slaves, model descriptions, packing."""
