"""A season on a Dask cluster gives what one process gives."""

import pytest
from typer.testing import CliRunner

from robocon_course.cli import app
from robocon_course.worlds import season


def test_a_cluster_gives_the_same_matches_as_one_process():
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        told = []

        def run(work, items):
            return (one.result() for one in client.map(work, items, pure=False))

        there = season([3], opponent="strong", run=run, on_match=told.append)
    here = season([3], opponent="strong")
    assert told == there
    assert there[0].history == here[0].history and there[0].events == here[0].events
    assert (there[0].poses == here[0].poses).all()


def test_a_cluster_that_is_not_there_is_told_in_a_sentence():
    ran = CliRunner().invoke(
        app, ["season", "--seeds", "1", "--scheduler", "tcp://127.0.0.1:9", "--patience", "0.5"]
    )
    assert ran.exit_code == 2 and "no Dask scheduler answers" in ran.output
