"""From photos or a dataset to the scene on disk: readers per format, one writer."""
