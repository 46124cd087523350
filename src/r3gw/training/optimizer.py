"""Adam over every parameter of the model, one named group each."""

from collections.abc import Iterable
from typing import Any

import torch

from r3gw.model import foreground, sky
from r3gw.model.attributes import FOREGROUND, SKY
from r3gw.model.model import SceneModel
from r3gw.native import kernels, ops
from r3gw.training.lights.kinds import training_of
from r3gw.training.schedule import Schedule
from r3gw.training.settings import RateSettings, TrainSettings

EPSILON = 1e-15
POSITIONS = tuple(
    f"{prefix}{attribute.name}"
    for prefix, attributes in ((foreground.PREFIX, FOREGROUND), (sky.PREFIX, SKY))
    for attribute in attributes
    if attribute.rate == "position"
)


def make_optimizer(model: SceneModel, settings: TrainSettings) -> torch.optim.Adam:
    """Adam with the settings' learning rates; ``group["name"]`` says what a group trains."""
    rates = settings.rates
    groups: list[dict[str, Any]] = [
        {
            "name": f"{rows.prefix}{attribute.name}",
            "params": [rows[attribute.name]],
            "lr": rates.named(attribute.rate),
        }
        for rows, attributes in ((model.foreground, FOREGROUND), (model.sky.rows, SKY))
        for attribute in attributes
    ]

    def add(name: str, parameters: Iterable[torch.nn.Parameter], rate: float) -> None:
        groups.append({"name": name, "params": list(parameters), "lr": rate})

    add("sky.radius", [model.sky.radius], rates.named("sky_radius"))
    if settings.sky.is_closed:
        for group in groups:
            if group["name"].startswith(sky.PREFIX):
                group["lr"] = 0.0
    embedding, light_model = model.appearance.embedding, model.appearance.light_model
    if own := list(light_model.parameters()):
        add("light", own, training_of(light_model).rate(settings))
    apart = {id(parameter) for parameter in (*own, embedding)}
    mlp = [p for p in model.appearance.parameters() if id(p) not in apart]
    add("embedding", [embedding], rates.named("embedding"))
    add("mlp", mlp, rates.named("mlp"))
    for group in groups:
        group["first_lr"] = group["lr"]
    return torch.optim.Adam(groups, eps=EPSILON, fused=True)


def adam_step(optimizer: torch.optim.Adam) -> None:
    """Do what ``optimizer.step()`` and ``zero_grad()`` do, with one kernel for all parameters.

    torch calls one per group, and with a dozen groups of small tensors its bookkeeping takes longer
    than the arithmetic. State and groups stay torch's, for densification and checkpoints. Where no
    kernel takes the parameters, torch's own step does it.
    """
    parameters = [p for group in optimizer.param_groups for p in group["params"]]
    if not kernels.take("adam_step", *parameters):
        optimizer.step()
        optimizer.zero_grad()
        return
    values: list[torch.Tensor] = []
    states: list[dict[str, torch.Tensor]] = []
    rates: list[float] = []
    for group in optimizer.param_groups:
        for parameter in group["params"]:
            state = optimizer.state[parameter]
            if not state:
                state["step"] = torch.zeros(())
                state["exp_avg"] = torch.zeros_like(parameter, requires_grad=False)
                state["exp_avg_sq"] = torch.zeros_like(parameter, requires_grad=False)
            values.append(parameter)
            states.append(state)
            rates.append(group["lr"])
    ops.adam_step(
        values,
        [state["exp_avg"] for state in states],
        [state["exp_avg_sq"] for state in states],
        [state["step"] for state in states],
        rates,
        optimizer.defaults["betas"],
        optimizer.defaults["eps"],
    )


def set_rates(
    optimizer: torch.optim.Adam, rates: RateSettings, schedule: Schedule, iteration: int
) -> None:
    """Let the learning rates fall as the schedule says: positions all the time, others late."""
    position = schedule.position_rate(iteration, rates.position_first, rates.position_last)
    share = schedule.late_share(iteration, rates.late_share)
    for group in optimizer.param_groups:
        if group["first_lr"] == 0:
            continue  # what stays as it is, such as a closed sky
        if group["name"] in POSITIONS:
            group["lr"] = position * rates.spatial_scale
        elif share < 1.0:
            group["lr"] = share * group["first_lr"]
