"""NumPy's functions on models of functions: np.sqrt(f) and np.float64(2) * f give models again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import methodcaller, neg
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

UfuncRules = Mapping[np.ufunc, Callable[..., Any]]
ARITHMETIC: UfuncRules = MappingProxyType(
    {
        np.add: lambda a, b: b.__radd__(a),
        np.subtract: lambda a, b: b.__rsub__(a),
        np.multiply: lambda a, b: b.__rmul__(a),
        np.divide: lambda a, b: b.__rtruediv__(a),
        np.negative: neg,
        np.absolute: abs,
        np.sqrt: methodcaller("sqrt"),
    }
)


class UfuncDispatch:
    """What NumPy's functions go by.

    Attributes:
        rules: NumPy's names for what models do.
    """

    __slots__ = ()
    rules: ClassVar[UfuncRules] = ARITHMETIC

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        rule = self.rules.get(ufunc)
        if rule is None or method != "__call__" or kwargs:
            return NotImplemented
        return rule(*inputs)
