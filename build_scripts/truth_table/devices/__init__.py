"""Virtual devices of other laws than the catalogue's: what a diagnosis makes of devices that somebody else built.

drive: the motion and the time stepping. slip, flow, joints: the laws. registry: which there are. rigs: test plans and
sensors. cases, judge, table: as the modules of these names beside this folder. None of the first four shares code with
the package that is put to the test.
"""
