"""Parts of `bifurcation_picture`: attractors of columns, their names, branches, the dataset."""
