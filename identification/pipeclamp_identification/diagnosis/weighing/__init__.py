"""What the candidates make of the verdict.

Causes, parts and rivals are told apart here and nowhere else.
What the candidates are, and how they are judged, stands beside this room.
"""
