"""What a coupled system is: its file, its excitation, the scheme of coupling, and when a result is to be trusted.

Read and checked here.
Nothing is run.
"""
