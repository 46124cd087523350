"""Fuzzing of every reader: mutated files must be read, or refused by an InputError, and quickly.

``python -m support.fuzzing`` (make fuzz) runs it at length; tests/fuzz runs a little of it.
"""
