"""The compiled extension ``r3gw._C``: what its kernels share (csrc), and its build."""
