"""The losses of the paper (Eq. 12-17).

`picture` and `regularisers` are the kernels that training uses; the other modules define the losses
in plain torch, and tests hold the kernels against them.
"""
