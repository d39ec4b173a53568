"""The rotor in a preloaded snubber ring: figures and claims of section 4."""
