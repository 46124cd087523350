"""The embedded benchmark: three synthetic outdoor scenes with ground truth, rendered by Mitsuba."""
