"""
Growth of a crack to the end
============================

The length of a crack over time under three loads of one amplitude and different means, by
Walker's law with published constants of aluminium 2024-T3. A larger mean load shortens the
life, which Paris' law would not know.
"""

import matplotlib.pyplot as plt

import nonsmooth as ns

specimen = ns.fatigue.Specimen()
law = ns.fatigue.published_laws()["walker 2024-T3"]
styles = ("-", "--", "-.")
figure, ax = plt.subplots(figsize=(4.4, 3.3), dpi=150, layout="constrained")
for mean, style, colour in zip((120.0, 160.0, 200.0), styles, ns.plot.PALETTE.values()):
    load = ns.fatigue.LoadBlock.constant_amplitude(mean=mean, amplitude=100.0, frequency=20.0)
    grown = ns.fatigue.life(
        specimen.stress_intensity, law, load, initial=6.4, final=19.0, toughness=34.0
    )
    label = f"{mean:.0f} N ± 100 N"
    ax.plot(grown["time"] / 3600, grown["crack"], style, color=colour, label=label)
ax.set(xlabel="time [h]", ylabel="length of the crack [mm]")
ax.legend(title="load at 20 Hz")
