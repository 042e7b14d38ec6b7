"""A client that openapi-python-client made, in use: a machine, kinematics, a program compensated, a posted job, a problem, a key.

TRUNNION_URL and TRUNNION_KEY (a key with every scope) say where; the argument is a program.
"""

import hashlib
import io
import os
import sys
import time

from trunnion_client import AuthenticatedClient
from trunnion_client.api.jobs import create_job, get_job, get_job_program
from trunnion_client.api.keys import create_api_key
from trunnion_client.api.kinematics import solve_forward_kinematics, solve_inverse_kinematics
from trunnion_client.api.machines import put_machine
from trunnion_client.api.programs import compensate_cc_path
from trunnion_client.models import (
    ApiKeyRequest, CcCompensationJob, CcCompensationJobOperation, CcParameters, ForwardRequest, InverseRequest, Job, JobForm,
    JobState, Kinematics, MachineDocument, MachineProfile, NewApiKey, Pose, Problem, ProgramForm, RotaryAxis, Scope, Side)
from trunnion_client.types import File

url, key = os.environ["TRUNNION_URL"], os.environ["TRUNNION_KEY"]
program = open(sys.argv[1], "rb").read()
client = AuthenticatedClient(base_url=url, token=key, timeout=60)
# One resource, several faces: without this the answer is the program.
reports = client.with_headers({"Accept": "application/json"})

profile = MachineProfile(
    name="made by a Python client",
    kinematics=Kinematics(rotary_axes=[
        RotaryAxis(name="A", side=Side.TABLE, direction=[1, 0, 0], point_mm=[0, 0, 0], limits_deg=[-120, 120]),
        RotaryAxis(name="C", side=Side.TABLE, direction=[0, 0, 1], point_mm=[0, 0, 0], limits_deg=None)]))
machine = put_machine.sync("python-client", client=client, body=profile)
assert isinstance(machine, MachineDocument) and machine.revision == 1, machine

pose = Pose(x=10, y=20, z=30, i=0.3, j=-0.2, k=0.93)
solved = solve_inverse_kinematics.sync("python-client", client=client, body=InverseRequest(poses=[pose]))
back = solve_forward_kinematics.sync("python-client", client=client, body=ForwardRequest(joints=solved.joints))
assert max(abs(back.poses[0].x - 10), abs(back.poses[0].y - 20), abs(back.poses[0].z - 30)) < 1e-9, back

report = compensate_cc_path.sync_detailed(
    "python-client", client=reports,
    body=ProgramForm(
        parameters=CcParameters(tool_radius_mm=5, work_offset_mm=[12, -7, 35]), program=File(io.BytesIO(program), "blade.nc")))
assert report.parsed.before.max_um > 10 >= report.parsed.after.max_um, report
answered = get_job_program.sync_detailed(report.headers["location"].rsplit("/")[-1], client=client).content
assert hashlib.sha256(answered).hexdigest() == report.parsed.output_sha256

form = lambda: JobForm(
    job=CcCompensationJob(
        machine_id="python-client", operation=CcCompensationJobOperation("cc-compensation"), external_id="WO-4711/20",
        parameters=CcParameters(tool_radius_mm=5, work_offset_mm=[12, -7, 35])),
    program=File(io.BytesIO(program), "blade.nc"))
job = create_job.sync(client=client, body=form(), idempotency_key="WO-4711/20 python")
assert isinstance(job, Job), job
assert create_job.sync(client=client, body=form(), idempotency_key="WO-4711/20 python").id == job.id
deadline = time.monotonic() + 60
while job.state in (JobState.QUEUED, JobState.RUNNING):
    assert time.monotonic() < deadline, job
    time.sleep(0.05)
    job = get_job.sync(job.id, client=client)
assert job.state == JobState.SUCCEEDED and job.external_id == "WO-4711/20", job
assert get_job_program.sync_detailed(job.id, client=client).content == answered

problem = solve_inverse_kinematics.sync(
    "python-client", client=client, body=InverseRequest(poses=[Pose(x=0, y=0, z=0, i=0, j=0, k=0)]))
assert isinstance(problem, Problem) and problem.status == 422, problem
assert problem.type_ == "/problems/invalid-request" and problem.errors[0].pointer.startswith("/poses/0"), problem

made = create_api_key.sync(client=client, body=ApiKeyRequest(name="reader", scopes=[Scope.READ]))
assert isinstance(made, NewApiKey) and made.key.startswith("trn_"), made
reader = AuthenticatedClient(base_url=url, token=made.key)
refused = put_machine.sync("python-client", client=reader, body=profile)
assert isinstance(refused, Problem) and refused.status == 403, refused
print("the Python client works")
