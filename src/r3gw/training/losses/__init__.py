"""The losses of the paper (Eq. 12 to 17) and ours: defined in plain torch, fused for speed.

`reconstruction`, `geometry`, `separation` and `lighting` define them; `forms` says how training
chooses between the plain and the fused form.
"""
