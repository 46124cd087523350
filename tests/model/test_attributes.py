"""The table of attributes: what it says fits what rows, settings and files expect."""

import pytest
import torch
from support.settings import train_settings

from r3gw.model.attributes import FOREGROUND, MATERIALS, SKY, first_rows, materials_of
from r3gw.model.rows import Rows
from r3gw.training.settings import RateSettings

ALL = {attribute.name: attribute for attribute in (*FOREGROUND, *SKY)}


@pytest.mark.parametrize("name", ALL)
def test_shape_columns_and_rate_fit(name):
    attribute = ALL[name]
    assert len(attribute.columns) in (0, torch.Size(attribute.shape).numel())
    assert attribute.rate == "position" or attribute.rate in RateSettings.model_fields
    if attribute.first is not None:
        rows = attribute.first(torch.rand(5, 3), train_settings().init)
        assert rows.shape == (5, *attribute.shape)


def test_no_two_attributes_share_a_column():
    columns = [column for attribute in ALL.values() for column in attribute.columns]
    assert len(columns) == len(set(columns))


def test_surfaces_start_with_the_material_of_the_settings():
    init = train_settings(init={"albedo": 0.3, "roughness": 0.6}).init
    found = materials_of(Rows("foreground.", first_rows(FOREGROUND, torch.rand(4, 3), init)))
    assert set(found) == set(MATERIALS) == {"albedo", "roughness"}
    torch.testing.assert_close(found["albedo"], torch.full((4, 3), 0.3), rtol=1e-6, atol=0)
    torch.testing.assert_close(found["roughness"], torch.full((4,), 0.6), rtol=1e-6, atol=0)


def test_rates_are_boosted_where_they_are_slow():
    rates = train_settings(rates={"short_run_boost": 3.0}).rates
    assert rates.named("position") == pytest.approx(1.6e-4 * 5.0, rel=1e-12)
    assert rates.named("albedo") == pytest.approx(3 * 0.002, rel=1e-12)
    assert rates.named("opacity") == pytest.approx(0.05, rel=1e-12)
