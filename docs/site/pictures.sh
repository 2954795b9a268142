#!/usr/bin/env bash
# ./run pictures, study-pictures and law-pictures: the pictures of the pages, made anew from runs.
#
#   pictures.sh readme | studies | laws PYTHON PROGRAM       from the top of the tree
set -euo pipefail
mkdir -p docs/images
case "$1" in
  readme)
    ./run cube
    cp out/cube/fig2_elastic_stretch.png out/cube/fig4_sarcomere_number.png docs/images/
    ./run cylinder
    cp out/cylinder/fig3_sections.png docs/images/cylinder_sections.png
    cp out/cylinder/fig2_elastic_stretch.png docs/images/cylinder_elastic_stretch.png
    ./run web --picture docs/images/web_play.png
    ;;
  studies)
    ./run fit examples/identification/example.csv
    ./run validate
    ./run protocol examples/protocols/{step1,step2,step4,step8,continuous}.csv
    ./run protocol examples/protocols/muscle.csv --design 1.14 --limit 1.05
    ./run sensitivity
    ./run fit examples/identification/example_all.csv --out out/fit/all
    cp out/fit/all/profiles.png out/fit/all/profiles_all.png
    for picture in fit/example/fit fit/example/profiles fit/all/profiles_all validation/validation protocol/protocols \
        design/design sensitivity/local sensitivity/global; do
      cp "out/$picture.png" "docs/images/studies_${picture##*/}.png"
    done
    ;;
  laws)
    "$2" docs/site/law_curves.py "$3" docs/images
    ;;
  *) echo "usage: pictures.sh readme | studies | laws PYTHON PROGRAM" >&2; exit 2 ;;
esac
