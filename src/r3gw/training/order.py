"""Which photo comes next: every epoch all of them, in a new random order."""

import torch


class PhotoOrder:
    """An endless sequence of photo indices whose state can be saved."""

    def __init__(self, count: int) -> None:
        """Start before the first epoch of ``count`` photos."""
        self.count = count
        self.left: list[int] = []

    def next(self, generator: torch.Generator) -> int:
        """The next index; a new epoch draws its order from ``generator``."""
        if not self.left:
            self.left = torch.randperm(self.count, generator=generator).tolist()
        return self.left.pop()
