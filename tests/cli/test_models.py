import nonsmooth as ns


def test_the_table_names_every_model(call):
    result = call("models")
    assert result.exit_code == 0
    names = {line.split()[0] for line in result.stdout.splitlines() if line.strip()}
    assert "moling" in names
    assert not names & {"MolingRig", "progression"}  # no systems, though models exports them
    assert "Ground mole of Pavlovskaia, Wiercigroch and Grebogi (2001)" in result.stdout


def test_one_model_with_its_equations(call):
    result = call("models", "moling")
    assert result.exit_code == 0
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert "phi = pi/2 = 1.5708 phase of the forcing" in lines
    assert "T = 2*pi/omega = 62.8319" in lines
    assert "y = 0 at rest velocity of the mass" in lines
    assert "x = p + v displacement of the mass" in lines
    assert "exit impact when q + g - p < 0 to contact" in lines
    assert "p = q + g slaved" in lines
    assert "R = 0 in this mode" in lines
    assert "xi > 0 the slider needs damping, its force is 2*xi*y + q" in lines
    for name in ns.models.moling().mode_names:
        assert f"mode {name}" in lines


def test_resets_and_exits_to_the_same_mode(call, accumulating):
    result = call("models", "ball")
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert any(line.endswith("when h < 0 to the same mode, u := -r*u") for line in lines)


def test_unknown_model(call):
    result = call("models", "molling")
    assert result.exit_code == 2
    assert "unknown model 'molling'; did you mean 'moling'?" in result.stderr
    assert result.stdout == ""
