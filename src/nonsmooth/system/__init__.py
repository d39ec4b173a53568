"""What a model is: texts, their meaning, checks, and the arrays made of them."""
