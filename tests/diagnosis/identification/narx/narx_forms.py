"""Regressors of several forms, by name."""

from ffgym.diagnosis.identification.narx import Regressors

FORMS = {
    "(6.19)": Regressors(speed_lags=(0, 1), output_lags=()),
    "(6.20)": Regressors(),
    "long": Regressors(speed_lags=(0, 1, 4), output_lags=(1, 3)),
    "slip": Regressors(slip_widths=(0.002, 0.02), output_lags=()),
    "all": Regressors(speed_lags=(0, 2), slip_widths=(0.01,), output_lags=(2,)),
}
"""Of the thesis, with longer lags, with slip elements, with everything."""
