"""A typed hazard agrees with nominal life and use class, or these are left out of the report."""

import pytest

from assessment.analyses.demand import demand_return_periods
from assessment.project.model import build_model
from assessment.project.project import load_project
from assessment.results.summary import printed
from assessment.runtime.errors import ProjectError
from assessment.workflow.stages import run
from tests.support.block_project import PROJECT, write_block


def project(folder, period="", use_class="II"):
    """The block, SLV typed in with a return period or without; nominal life 50 years."""
    hazard = f"SLV = {{ag_g = 0.261, F0 = 2.36, Tc_star_s = 0.35{period}}}\n"
    site = f'[assessment.site]\nsoil = "B"\nnominal_life_years = 50\nuse_class = "{use_class}"\n{hazard}'
    assessment = '[assessment]\nlimit_states = ["SLV"]\nmodel = "none"\n'
    return load_project(write_block(folder, PROJECT + assessment + site))


def test_the_return_period_is_that_of_nominal_life_and_use_class(tmp_path):
    """−50/ln 0.9 = 474.56 years, rounded 475; of class III −75/ln 0.9 = 711.8."""
    assert demand_return_periods(project(tmp_path, ", return_period_years = 475")) == {"SLV": 475.0}
    assert demand_return_periods(project(tmp_path, ", return_period_years = 712", "III")) == {"SLV": 712.0}


def test_one_that_contradicts_them_is_refused(tmp_path):
    with pytest.raises(ProjectError, match=r'SLV\.return_period_years: 475 years.*"III" make 711\.8 at SLV'):
        project(tmp_path, ", return_period_years = 475", "III")


@pytest.mark.parametrize(("period", "known"), [("", False), (", return_period_years = 475", True)])
def test_without_one_they_are_not_printed_and_no_index_rests_on_them(tmp_path, period, known):
    content = project(tmp_path, period)
    results = run(content, build_model(content), jobs=1).results
    site = printed(results.echo)["assessment"]["site"]
    assert {"nominal_life_years", "use_class"} <= site.keys() if known else "use_class" not in site
    indices = results.states["original"].indices
    assert (indices.I_S is not None) == (indices.acceptable_nominal_life_years is not None) == known
