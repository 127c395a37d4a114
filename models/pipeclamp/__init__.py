"""The physics of the clamp and of the pipe: effects, law, parameter file, pipe."""
