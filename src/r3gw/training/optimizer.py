"""Adam over every parameter of the model, one named group each (method 8)."""

from typing import Any

import torch

from r3gw.model.model import SceneModel
from r3gw.native import kernels, ops
from r3gw.training.schedule import Schedule

EPSILON = 1e-15
POSITIONS = ("foreground.means", "sky.angles")


def make_optimizer(model: SceneModel) -> torch.optim.Adam:
    """Adam with the settings' learning rates; ``group["name"]`` says what a group trains."""
    rates = model.settings.rates
    slow = rates.short_run_boost
    by_name = {
        "foreground.means": rates.position_first * rates.spatial_scale,
        "foreground.albedo_logits": rates.albedo * slow,
        "foreground.roughness_logits": rates.roughness * slow,
        "sky.angles": rates.position_first * rates.spatial_scale,
        "sky.radius": rates.sky_radius * slow,
    }
    for prefix in ("foreground.", "sky."):
        by_name[f"{prefix}log_scales"] = rates.scale
        by_name[f"{prefix}quaternions"] = rates.rotation
        by_name[f"{prefix}opacity_logits"] = rates.opacity
    groups: list[dict[str, Any]] = [
        {"name": f"{rows.prefix}{name}", "params": [parameter]}
        for rows in (model.foreground, model.sky.rows)
        for name, parameter in rows.values.items()
        if parameter.requires_grad
    ]
    groups.append({"name": "sky.radius", "params": [model.sky.radius]})
    for group in groups:
        group["lr"] = by_name[str(group["name"])]
    embedding, outdoor = model.appearance.embedding, model.appearance.outdoor
    if outdoor is not None:
        rate = model.settings.outdoor.sun_rate * slow
        groups.append({"name": "sun", "params": list(outdoor.parameters()), "lr": rate})
    apart = {id(p) for group in groups for p in group["params"]} | {id(embedding)}
    mlp = [p for p in model.appearance.parameters() if id(p) not in apart]
    groups.append({"name": "embedding", "params": [embedding], "lr": rates.embedding * slow})
    groups.append({"name": "mlp", "params": mlp, "lr": rates.mlp * slow})
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


def set_position_rate(
    optimizer: torch.optim.Adam, model: SceneModel, schedule: Schedule, iteration: int
) -> None:
    """Let the learning rate of positions decay as the schedule says."""
    rates = model.settings.rates
    rate = schedule.position_rate(iteration, rates.position_first, rates.position_last)
    for group in optimizer.param_groups:
        if group["name"] in POSITIONS:
            group["lr"] = rate * rates.spatial_scale
