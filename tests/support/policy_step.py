"""A step of learning by policy gradient, with PyTorch: what the tests of trainers' simulators have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def learn(observe: Callable[[], Any], act: Callable[[Any], Any], actions: int, *, steps: int) -> tuple[Any, Any]:
    """Let a small policy act, and take one step along the gradient of its rewards; gives observations and rewards.

    observe: (worlds, values); act: actions (worlds, actions) to rewards (worlds,). The observations are
    (steps, worlds, values), the rewards (steps, worlds). Asserts that there was something to learn, that every
    parameter changed, and that the policy now prefers what was rewarded.
    """
    import torch

    torch.manual_seed(1)
    policy = torch.nn.Sequential(torch.nn.LazyLinear(32), torch.nn.Tanh(), torch.nn.Linear(32, actions))
    rows = []
    for _ in range(steps):
        seen = torch.as_tensor(observe(), dtype=torch.float32)
        with torch.no_grad():
            taken = torch.distributions.Normal(policy(seen), 1.0).sample()
        rows.append((seen, taken, torch.as_tensor(act(taken), dtype=torch.float32)))
    observed, taken, rewards = (torch.stack(column) for column in zip(*rows, strict=True))
    assert torch.isfinite(observed).all()
    assert torch.isfinite(rewards).all()
    returns = rewards.flip(0).cumsum(0).flip(0)
    advantage = (returns - returns.mean()) / returns.std()
    assert rewards.std() > 0

    def loss() -> Any:
        chance = torch.distributions.Normal(policy(observed), 1.0).log_prob(taken).sum(-1)
        return -(chance * advantage).mean()

    optimizer = torch.optim.Adam(policy.parameters(), lr=1e-3)
    before, first = [own.detach().clone() for own in policy.parameters()], loss()
    first.backward()
    optimizer.step()
    assert all(bool((own != old).any()) for own, old in zip(policy.parameters(), before, strict=True))
    assert loss() < first
    return observed, rewards
