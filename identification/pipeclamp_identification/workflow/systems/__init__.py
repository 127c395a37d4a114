"""What people do with a coupled system: compute it, hold it against what was measured on its pipe, and what comes next.

Commands and the Python API call it. A system is named by its file, SYSTEM.toml.
"""
