"""Predictions against ground truth, as numbers."""
