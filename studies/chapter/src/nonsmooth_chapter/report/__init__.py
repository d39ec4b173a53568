"""The report of the chapter: texts beside the figures, and the page that holds all."""
