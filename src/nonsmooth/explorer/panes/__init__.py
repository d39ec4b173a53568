"""The panes of a page, one file each: a figure, and how a piece of a task is shown in it."""
