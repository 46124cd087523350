"""The compiled extension ``r3gw._C``: typed operators, when they act, what kernels share."""
