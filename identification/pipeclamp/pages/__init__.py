"""What people look at: pages with pictures, one HTML file each, that open without a network.

Nothing is computed here but what a picture needs.
Plotly and Jinja stay in this room.
"""
