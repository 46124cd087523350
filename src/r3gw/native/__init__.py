"""The compiled extension: which one a machine loads, typed operators, what kernels share."""
