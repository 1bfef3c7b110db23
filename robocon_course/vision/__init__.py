"""What the camera sees: pictures made and looked at, networks trained and run.

`classes` names what is told apart. `camera`, `scene` and `pictures` make pictures of the field with
boxes, `dataset` writes thousands of them, `training` turns them into weights. `detection` runs the
weights, `metrics` says how good they are, `locate` turns boxes into bearings and ranges, `colour`
is the older way without a network.
"""
