#!/bin/sh
# Makes one page of every command that writes one, from the files that ship: make-pages.sh LOSTMOTION FOLDER
set -eu
lostmotion=$(realpath "$1")
out=$(realpath -m "$2")
cd "$(dirname "$0")/../.."
rm -rf "$out"
mkdir -p "$out/work"
work=$out/work
kuka=configs/kuka-kr120-r2500-pro.yaml
model=samples/models/kuka-figure5.model.yaml
program=samples/circle/circle_program.csv
static=samples/static/single_axis_A1.csv.gz
arm=tests/data/machines/arm

# an answer that is no (exit code 1) has a page, too
run() { "$lostmotion" -q "$@" >/dev/null || [ $? -eq 1 ]; }

run identify static --robot $kuka --log $static --output "$work/gaps.yaml" --report "$out/identify-static.html"
run identify path --robot $kuka --log samples/circle/circle_uncompensated_figure5.csv.gz --output "$work/path.yaml" --report "$out/identify-path.html"
run identify --robot $arm/robot.yaml --log $arm/static_J1.csv.gz --log $arm/static_J2.csv.gz --log $arm/circle.csv.gz \
  --log $arm/excitation.csv.gz --output "$work/machine.yaml" --report "$out/identify.html"
run fit --robot $kuka --gaps "$work/gaps.yaml" --output "$work/comp.yaml" --report "$out/fit.html"
run rewrite --robot $kuka --compensator "$work/comp.yaml" $program --speed-mm-s 1.5 --output "$work/circle.csv" --report "$out/rewrite.html"
run rewrite --model $model samples/programs/krl --speed-mm-s 20 --output-dir "$work/done" --fail-on none --report "$out/rewrite-folder.html"
run simulate --model $model --input $program --speed-mm-s 20 --rate-hz 20 --noise-um 11 --output "$work/log.csv" --report "$out/simulate.html"
run assess program --model $model --before $program --after "$work/circle.csv" --report "$out/assess-program.html"
run assess circle --robot $kuka --nominal $program --before samples/circle/circle_uncompensated_figure5.csv.gz --report "$out/assess-circle.html"
run assess impact --model $model --pose 40,-10,5,0,0,0 --report "$out/assess-impact.html"
run assess bidirectional --readings samples/bidirectional/irb1600_y.csv --report "$out/assess-bidirectional.html"
sed '/^effects:/,$d' $model | sed "s|../../configs|$PWD/configs|" >"$work/ideal.yaml"
run diagnose --model "$work/ideal.yaml" --log "$work/log.csv" --json --report "$out/diagnose.html"
instrument=configs/micro-iges-4dof.yaml
gantry=configs/gantry-xyz-ballscrew.yaml
run identify deadzone --robot $instrument --log samples/instrument/growing_sine_log.csv.gz --output "$work/deadzone.yaml" --report "$out/identify-deadzone.html"
run identify screw --robot $gantry --log samples/screw/gantry2015_z.csv.gz --output "$work/screw.yaml" --report "$out/identify-screw.html"
run learn --robot $instrument --log samples/instrument/excitation_compensated.log.csv.gz --commands samples/instrument/excitation.csv.gz --hidden 10 --coordinates xy --output "$work/kinematics.yaml" --report "$out/learn.html"
run track --robot $instrument --kinematics "$work/kinematics.yaml" --path samples/instrument/ellipse_12x20.csv --tolerance-mm 1 --output "$work/track.csv" --report "$out/track.html"
run plan-experiment --model $model --between backlash:A2,hysteresis:A2 --output "$work/plan.csv" --report "$out/plan-experiment.html"
for file in $kuka $model $program $static "$work/gaps.yaml" "$work/comp.yaml"; do
  name=$(basename "$file" | sed 's/\.csv.*//; s/\.yaml//; s/\.model//')
  case $file in
    $kuka | $model) run show "$file" --output "$out/show-$name.html" ;;
    *) run show "$file" --robot $kuka --output "$out/show-$name.html" ;;
  esac
done

# programs in the languages of makers, before and after: their joints reverse together at the points
fanuc=configs/fanuc-m10ia.yaml
{
  printf 'schema: lostmotion/model/1\nrobot: %s\neffects:\n' "$PWD/$fanuc"
  for joint in J1 J2 J3 J4 J5 J6; do printf '  - {effect: backlash, joint: %s, half_gap_deg: 0.004}\n' $joint; done
} >"$work/fanuc.yaml"
run rewrite --model "$work/fanuc.yaml" samples/programs/fanuc/reversal.ls --speed-mm-s 20 --output "$work/reversal.ls" --report "$out/rewrite-fanuc.html"
run show "$work/reversal.ls" --robot $fanuc --output "$out/show-fanuc.html"
run rewrite --model $model samples/programs/krl/folds.src --speed-mm-s 20 --output "$work/folds.src" --report "$out/rewrite-krl.html"
run show "$work/folds.src" --robot $kuka --output "$out/show-krl.html"

# a double ballbar about the middle of the circle, and a dial gauge along y, from what a tracker would have seen
column() { grep -v "^#" "$1" | head -1 | tr "," "\n" | grep -nx "$2" | cut -d: -f1; }
run simulate --model $model --input $program --speed-mm-s 20 --rate-hz 20 --noise-um 1 --seed 7 --output "$work/seen.log.csv"
grep -v "^#" "$work/seen.log.csv" >"$work/seen.csv"
awk -F, -v x="$(column "$work/seen.csv" x_mm)" 'NR > 1 { for (k = 0; k < 3; k++) s[k] += $(x + k); n++ } END { print s[0] / n, s[1] / n, s[2] / n }' \
  "$work/seen.csv" >"$work/middle.txt"
awk -F, -v OFS=, -v x="$(column "$work/seen.csv" x_mm)" -v middle="$(cat "$work/middle.txt")" 'BEGIN { split(middle, m, " ") }
  { line = $1; for (k = 2; k < x; k++) line = line OFS $k }
  NR == 1 { print line, "r_mm"; next }
  { print line, sprintf("%.6f", sqrt(($x - m[1]) ^ 2 + ($(x + 1) - m[2]) ^ 2 + ($(x + 2) - m[3]) ^ 2)) }' "$work/seen.csv" >"$work/ballbar.csv"
run identify path --robot $kuka --log "$work/ballbar.csv" --output "$work/ballbar.yaml" --report "$out/identify-ballbar.html"
gzip -dc $static | grep -v '^#' >"$work/static.csv"
awk -F, -v OFS=, -v x="$(column "$work/static.csv" x_mm)" '{ line = $1; for (k = 2; k < x; k++) line = line OFS $k }
  NR == 1 { print line, "dial_um"; next } $(x + 1) == "" { print line, ""; next } { print line, sprintf("%.3f", 1000 * $(x + 1)) }' \
  "$work/static.csv" >"$work/dial.csv"
run identify static --robot $kuka --log "$work/dial.csv" --direction 0,1,0 --output "$work/dial.yaml" --report "$out/identify-dial.html"
