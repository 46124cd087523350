"""A scene before and after its import."""

import pytest
from support.patient import Patient


@pytest.fixture
def patient(tmp_path, repository):
    return Patient(tmp_path, repository / "config")


@pytest.fixture
def made(patient):
    patient.make()
    return patient
