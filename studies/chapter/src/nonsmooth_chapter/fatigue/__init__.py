"""Section 3: a specimen with a fatigue crack that breathes and grows."""
