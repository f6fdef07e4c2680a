"""Text of ``help``; some of its characters are more than one byte long."""

from __future__ import annotations

COMMANDS = """\
Commands:
  help                    this text
  ?                       this text too
  version                 version of the firmware
  signature               signature of the firmware
  port <port>             the port that further commands mean (at first 0)
  list                    what is plugged in, port by port
  vin                     supply voltage
  ledmode <ledmode>       what the lights show
  clear_faults            forget faults of the motor drivers that are over
  echo <0|1>              repeat received characters and show a prompt
  debug <debugcode>       more output, for the curious

Driving:
  pwm                     the set point is the drive (so it is at first)
  pid <pidparams>         the set point is that of a variable
  pid_diff <pidparams>    the set point is that of a variable's rate of change
  set <setpoint>          a constant set point
  set <waveparams>        a set point that changes with time
  on                      set 1
  off                     set 0
  coast                   switch the motor driver off
  plimit <limit>          largest drive of all ports (at first 0.1)
  port_plimit <limit>     largest drive of this port
  pwmparams <pwmparams>   what becomes of small drives

Data:
  select <mode>           report a mode of the device
  select <var>            report one number of a mode
  select                  end the reports
  selonce <mode>          report one message only
  selonce <var>           report one number only once
  selrate <rate>          time between reports; to be given after select
  combi <slot> <pairs>    let the device send several modes together
  combi <slot>            no longer
  write1 <hexbyte>*       message to the device with one byte of header
  write2 <hexbyte>*       message to the device with two bytes of header
"""

ARGUMENTS = """\

Arguments:
  <port>                  0 to 3
  <ledmode>               0 none, 1 orange, 2 green, 3 both, –1 by supply (so it is at first)
  <limit>                 0 to 1, a part of full drive
  <setpoint>              –1 to +1 with pwm, anything with pid
  <waveparams>            square <min> <max> <period> <phase>
                          sine <min> <max> <period> <phase>
                          triangle <min> <max> <period> <phase>
                          pulse <during> <after> <length> 0
                          ramp <from> <to> <duration> 0
                          var <min> <max> <slope> <offset> <svar>
    <period>              in s, like length and duration
    <phase>               0 to 1
  <pidparams>             <svar> <Kp> <Ki> <Kd> <windup> <deadzone>
    <Kp> <Ki> <Kd>        gains, Δt in s
    <windup>              largest integral
    <deadzone>            errors below it are none
  <pwmparams>             <threshold> <least>
    <threshold>           smaller drives are made of slots of it (at first 0)
    <least>               smaller drives are none (at first 0)
  <svar>                  <port> <var> <scale> <unwrap>
    <scale>               factor
    <unwrap>              size of the circle, or 0
  <var>                   <mode> <offset> <format>
    <offset>              in bytes
    <format>              u1 s1 u2 s2 u4 s4 f4: type and size in bytes
  <pairs>                 {<mode> <dataset>}*
  <rate>                  in ms; 0: with each message of the device
  <hexbyte>               one or two hexadecimal digits
  <debugcode>             sum of 8 data messages, 16 controllers
"""

HELP = (COMMANDS + ARGUMENTS).replace("\n", "\r\n")
