"""Maps of a system from one section to the next: once per period, or wherever a surface is met."""
