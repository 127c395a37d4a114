"""What an FMU says of itself: model description, units, documentation, icon, the history of its law.

Text and XML only.
What the numbers are is decided in `contents`.
"""
