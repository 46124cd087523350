"""Checks everything that a run will need before hours of CPU go into it."""

from r3gw.doctor.doctor import examine

__all__ = ["examine"]
