"""Agents with a memory: recurrent PPO whose critic is told what no policy sees, and imitation over whole episodes."""
