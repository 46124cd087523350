"""The losses of the paper (Eq. 12-17), each a function of tensors."""
