from stretch_bt.model.calibration.conditioning import Conditioning


def test_it_is_said_in_words():
    assert str(Conditioning()) == "not conditioned"
    assert str(Conditioning(0.08, 0.015)) == "conditioned to a stretch of 80 mm and a depth of 15 mm"
