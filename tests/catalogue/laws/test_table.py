"""Every figure of the table of motion laws, as printed."""

import pytest

from synthesis.catalogue.laws import LAWS
from synthesis.catalogue.laws.base import Characteristics, characteristics

INF = None
# kind: Cv, Ca max, Ca min, Cj max, Cj min. Typed from the document, not from the code; a text
# is right to half a unit of its last digit.
TABLE: dict[str, tuple[str | None, ...]] = {
    "constant_velocity": ("1", INF, INF, INF, INF),
    "parabolic": ("2", "4", "-4", INF, INF),
    "simple_harmonic": ("1.57080", "4.93480", "-4.93480", INF, "-15.5031"),
    "cubic_2_3": ("1.5", "6", "-6", INF, "-12"),
    "cycloidal": ("2", "6.28319", "-6.28319", "39.4784", "-39.4784"),
    "modified_trapezoid": ("2", "4.88812", "-4.88812", "61.4260", "-61.4260"),
    "modified_sine": ("1.75960", "5.52796", "-5.52796", "69.4664", "-23.1555"),
    "gutman_1_3": ("2", "5.13020", "-5.13020", "59.2176", "-59.2176"),
    "freudenstein_1_3": ("2", "5.38559", "-5.38559", "50.7580", "-50.7580"),
    "freudenstein_1_3_5": ("2", "5.06028", "-5.06028", "59.6151", "-59.6151"),
    "polynomial_3_4_5": ("1.875", "5.77350", "-5.77350", "60", "-30"),
    "polynomial_4_5_6_7": ("2.1875", "7.51319", "-7.51319", "42", "-52.5"),
    "polynomial_5_6_7_8_9": ("2.46094", "9.37198", "-9.37198", "51.4286", "-78.75"),
    "polynomial_6_7_8_9_10_11": ("2.70703", "11.26658", "-11.26658", "64.1667", "-108.2813"),
    "peisakh_11": ("2.05078", "7.91000", "-7.91000", "56.9326", "-38.9345"),
    "polynomial_5": ("1.875", "5.77350", "-5.77350", "60", "-30"),  # between rests: 3-4-5
    "polynomial_7": ("2.1875", "7.51319", "-7.51319", "42", "-52.5"),  # between rests: 4-5-6-7
    "trapezoidal_acceleration": ("2", "5.33333", "-5.33333", "42.66667", "-42.66667"),
    "mcv50_makino": ("1.27526", "8.01268", "-8.01268", "201.3807", "-67.1269"),
    "cv50_half_sine": ("1.33333", "8.37758", "-8.37758", "105.2758", "-105.2758"),
    "cv50_modified_trapezoid": ("1.33333", "6.51750", "-6.51750", "163.8026", "-163.8026"),
    "cv50_parabolic": ("1.33333", "8", "-8", "128", "-128"),
    "cv50_haversine": ("1.33333", "10.66667", "-10.66667", "134.0413", "-134.0413"),
    "scca_cv20": ("1.66667", "5.09180", "-5.09180", "79.9817", "-79.9817"),
    "double_harmonic": ("2.04052", "5.55165", "-9.86960", "20.58", "-42.41"),
    "polynomial_3_4_5_6": ("1.71730", "4.8", "-6", "48", "-21.46625"),
    "kloomok_muffley_8": ("1.77666", "5.26830", "-5.26830", "36.585", "-25.885"),
}
EXACT = {"1", "2", "4", "-4", "6", "-6", "8", "-8", "-12", "128", "-128", "60", "-30", "42"}
EXACT |= {"1.5", "1.875", "2.1875", "-52.5", "-78.75"}


def as_printed(value: float | None, text: str | None) -> bool:
    if value is None or text is None:
        return value is text
    if text in EXACT:
        return abs(value - float(text)) <= 1e-12 * abs(float(text))
    decimals = len(text.partition(".")[2])
    return abs(value - float(text)) <= 0.5 * 10.0**-decimals + 1e-12


def test_the_table_holds_every_law_but_the_one_with_parameters() -> None:
    assert set(TABLE) == set(LAWS) - {"scca"}


@pytest.mark.parametrize("kind", TABLE)
def test_peaks_are_as_printed(kind: str) -> None:
    measured = characteristics(LAWS[kind])
    found = (measured.Cv, measured.Ca_max, measured.Ca_min, measured.Cj_max, measured.Cj_min)
    for value, text in zip(found, TABLE[kind], strict=True):
        assert as_printed(value, text), f"{kind}: {found} against {TABLE[kind]}"


@pytest.mark.parametrize("kind", TABLE)
def test_infinities_are_reported(kind: str) -> None:
    measured = characteristics(LAWS[kind])
    _, a_max, a_min, j_max, j_min = TABLE[kind]
    assert (None in (measured.Ca_max, measured.Ca_min)) == (a_max is INF or a_min is INF)
    assert (None in (measured.Cj_max, measured.Cj_min)) == (j_max is INF or j_min is INF)


def test_peaks_survive_json() -> None:
    measured = characteristics(LAWS["simple_harmonic"])
    assert Characteristics.model_validate_json(measured.model_dump_json()) == measured
