"""Assembly guides: how the cut pieces of a sheet are put together, in words and pictures."""
