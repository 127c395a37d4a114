"""What raw samples need before they are a run: cut at rests and steps, spikes mended, clipped cycles cut off.

Each step gives words on what it did.
Nothing here knows of files or channels' names.
"""
