"""The buildings of the benchmark, one module each; a module's `PLACE` is all that others need."""
