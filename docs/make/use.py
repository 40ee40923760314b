"""How agents are trained, passed on and used elsewhere, as a section of the page of agents."""

from agents.export import EXAMPLE

USE = f"""## Train, resume, export

```sh
python train.py ppo --seeds 5 --run-folder runs/ppo  # five seeds, one after another; --jobs 2: two at a time
python train.py --resume runs/ppo                    # go on after Ctrl-C, bit for bit as without the stop
python -m agents.shipping.ship runs/ppo --name ppo   # evaluate all seeds, ship the median one, write its card
python -m agents.compare ablations                   # the table of choices above
python -m docs.make agents                           # this page
python train.py ppo --conf-file agents/hyperparams/soft_drive/ppo.yml  # an agent for the softened drive
```

`--device cuda` trains on a graphics card, which pays for large networks and batches; a run that goes on there is equal
to one without a stop but for rounding. `python train.py --help` lists the rest: hyperparameters and arguments of the
environment can be changed on the command line, and an unknown one is refused with the closest known name. A run's
folder holds its config, command, versions, evaluations and models.

Nothing that was learnt is lost: a checkpoint stays until the last model is whole, every file is whole or not there,
one process at a time trains in a folder, and a damaged file is named in one sentence. What is imitated before the first
trial, which takes minutes for `ppo_asymmetric`, goes on from `imitated.pt`; its episodes are played again. `train.py`
ends with 0 (done), 1 (failed), 2 (the arguments are not allowed), 130 (stopped by Ctrl-C) or 143 (by SIGTERM).

**What is imitated** is the key `imitation`, and a dot changes a part of it. A small training where nobody knows the
rig, a minute and a half of one core, which shows how all goes and learns little:

```sh
python train.py ppo_asymmetric --env DrillRigUnknown-v0 -n 409600 --threads 1 \\
    -params n_envs:256 critic_iterations:2 imitation.rounds:2 imitation.updates:100 imitation.last_updates:500
```

**A curriculum** is a key of a file of hyperparameters, or of `-params`:

```yaml
curriculum:
  scenarios:  # from easy to hard; then comes the environment's own
    - {{normal_force: [5, 15], load_step: 0}}
    - {{normal_force: [5, 25]}}
  noise: [0, 0.5]  # if at all, one for each of them
  delay: [0, [0, 1]]
  share: 0.8  # of the last episodes, mitigated before the next stage begins
  episodes: 200
```

Scenarios, noises and delays are given as the environment takes them, in the chapter rig's numbers, and no delay is
longer than its own; episodes that began in an earlier stage are not counted, evaluations are of the environment's own
all along, and what is imitated is imitated in the first. A training that goes on after a stop is as far as it was.

**A filter under the network** is the key `observer`, with the name of a policy that estimates: `-params observer:lqg`
puts what the filter of `lqg` makes of the measurements, seven states and the friction torque, in front of them. With
`ppo_asymmetric` the memory itself learns to tell rig, friction and state with `estimates:1.0`, and with
`through_estimates:true` the network acts on what it tells. A network behind a filter is not exported.

**Models of other people.** Stable-Baselines3 keeps settings in `model.zip` as pickles, and `PPO.load` runs whatever
code their maker put there. This project reads a run's settings from `config.json` and only tensors from
`model.zip`: `eval.py` and the export execute nothing that a run folder holds. `train.py --resume` does load the
checkpoint's pickles: go on with your own trainings only. To pass an agent on, use ONNX, which holds no code.

`python train.py --resume-from ppo` goes on from a shipped agent with its settings and a rate that begins anew. First
its critic learns alone, for `critic_iterations` rollouts; a training that would end before is refused. Others need
algorithm and environment too, `python train.py ppo_asymmetric --env DrillRigUnknown-v0 --resume-from ppo_unknown`.
`agents.training.fine_tuning.load_trainable("ppo", env)` gives its model for a loop of your own. Both warn where drive,
slew limit, control period or channels are not those that it learnt with: there it begins as another policy. An agent
whose critic is told more than it sees learns on in `make_sb3(1024, env_id="DrillRigUnknown-v0", privileged=True)`.

**In Stable-Baselines3 alone** an agent is a plain model. Its frames are SB3's own, oldest first, and its actions are
bit for bit those of `drillrig_env.policy.load("ppo")`:

```python
import drillrig_env
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecFrameStack

env = VecFrameStack(drillrig_env.make_sb3(16, seed=0), n_stack=8)
model = PPO.load("agents/trained/ppo/model.zip", env=env, device="cpu")
print(evaluate_policy(model, env, n_eval_episodes=16))  # mean and spread of the returns
```

Another agent needs its own environment, frames and slew limit: with `agent = load("ppo_robust")` it is
`VecFrameStack(make_sb3(16, env_id=agent.env_id, **agent.env_kwargs, slew_limit=agent.slew_limit), agent.frames)`, since
a model's action is a share of the slew limit that it was trained with, which the contract's agent takes care of.

**In rl-zoo3** the hyperparameter files train as they are where nothing is imitated first: those for the rig's own drive
in `agents/hyperparams/alone`, those for the softened one in `agents/hyperparams/soft_drive`, each for PPO and SAC.
`train.py` takes the same files.

```sh
python train.py ppo --conf-file agents/hyperparams/alone/ppo.yml
cd agents/hyperparams/alone
python -m rl_zoo3.train --gym-packages drillrig_env --env DrillRig-v0 --algo ppo -conf ppo.yml
```

rl-zoo3 steps single environments one by one, where `train.py` steps all rigs in one compiled call. The keys
`imitation`, `anchor`, `critic_iterations`, `staggered`, `curriculum` and `observer` are this project's own: rl-zoo3
hands them to the algorithm, which refuses them (`unexpected keyword argument 'imitation'`). So `ppo.yml`,
`ppo_robust.yml` and `sac.yml` in `agents/hyperparams`, which imitate first, are for `train.py` alone. Those in `alone`
were tried with rl_zoo3 2.9.2 for 98,304 steps (PPO) and 12,000 steps (SAC), 17 s of computing each, not to the end.

`python -m agents.export ppo --out policy.onnx` writes an agent as one file that takes measured values in physical units
by name and gives the rate of the speed reference in rad/s², and the reference itself, with scaling, clipping, memory,
slew limit and range inside; [what the file holds, and how to run it on hardware](hardware.md). It plays recorded
episodes through both and fails where they differ by 1e-6 of that limit. Networks are computed in double precision:
PyTorch's single precision moves the actions by some 1e-6 of its own, which the command prints too. This runs it, with
nothing but onnxruntime and NumPy:

```text
{EXAMPLE.strip()}
```
"""
