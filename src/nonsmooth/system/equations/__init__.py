"""The equations of one mode: names and piecewise calls resolved, slaved states solved for."""
