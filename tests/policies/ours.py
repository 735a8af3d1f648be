"""Every policy of ours, as a model names it, with the parameters that it has to be given."""

import dataclasses

from desim_warehouse.policies.catalogue import OURS, find, parameters_of

NUMBER = 30
"""Of a parameter without a default."""


def required(kind, name):
    """Return a value for each parameter of a policy that has no default."""
    accepted = parameters_of(find(kind, name))
    return {key: NUMBER for key, (_, default) in accepted.items() if default is dataclasses.MISSING}


def every(kind):
    """Return all policies of a kind."""
    return [{"name": name, **required(kind, name)} for name in OURS[kind]]


def completed(kind, some):
    """Return some policies of a kind, and all that are not among them."""
    names = {policy if isinstance(policy, str) else policy["name"] for policy in some}
    return [*some, *(policy for policy in every(kind) if policy["name"] not in names)]
