"""Campaigns that hold dW and W without records: read, fitted, compared, diagnosed.

Errors are log ratios here, and scatter is what the richest law leaves.
The paper's own tables come this way.
"""
