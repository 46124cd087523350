"""Checks everything that a run will need before hours of CPU go into it.

Import its modules: `r3gw.pipeline.doctor.training` looks at one run without loading PyTorch.
"""
