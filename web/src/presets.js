// Written by web/presets.py from ./run fit: do not edit. fitted: what the measurements decide; the rest is set in the file.
// set: removal, where the study has it.
export const PRESETS = [
  {
    "id": "paper",
    "title": "the paper, Table 1",
    "fitted": [],
    "source": "Javadi et al., Simulation of Biceps Femoris Muscle Growth Based on Stretch Using a Multiscale Model, Table 1",
    "values": {
      "tau": 0.5,
      "gamma": 2,
      "G_max": 1.1,
      "lambda_crit": 1.01
    }
  },
  {
    "id": "example",
    "title": "made-up study: 10 % stretch within a day",
    "source": "Made up: what a study with a measurement every few days could look like. The paper's Table 1, and normal noise of 0.003 from Python's random.Random(2012).gauss. File: examples/identification/example.csv",
    "fitted": [
      "tau",
      "lambda_crit"
    ],
    "values": {
      "tau": 0.44773,
      "gamma": 2.0,
      "G_max": 1.1,
      "lambda_crit": 1.0149
    }
  },
  {
    "id": "zollner_2012",
    "title": "Zöllner 2012: limb lengthening",
    "source": "Zöllner, Abilez, Böl, Kuhl 2012, Stretching skeletal muscle: chronic muscle lengthening through sarcomerogenesis, PLoS ONE 7(10):e45661. File: examples/identification/published/zollner_2012.csv",
    "fitted": [
      "tau"
    ],
    "values": {
      "tau": 0.33175,
      "gamma": 2.0,
      "G_max": 1.3,
      "lambda_crit": 1.01
    }
  },
  {
    "id": "boakes_2007",
    "title": "Boakes 2007: human femur lengthening",
    "source": "Boakes, Foran, Ward, Lieber 2007, Muscle adaptation by serial sarcomere addition 1 year after femoral lengthening, Clin Orthop Relat Res, pages 250-253. File: examples/identification/published/boakes_2007.csv",
    "fitted": [
      "G_max"
    ],
    "values": {
      "tau": 0.5,
      "gamma": 2.0,
      "G_max": 2.6256,
      "lambda_crit": 1.01
    }
  },
  {
    "id": "tabary_1972_lengthened",
    "title": "Tabary 1972: lengthened",
    "source": "Tabary, Tabary, Tardieu, Tardieu, Goldspink 1972, Physiological and structural changes in the cat's soleus muscle due to immobilization at different lengths by plaster casts, J Physiol. File: examples/identification/published/tabary_1972_lengthened.csv",
    "fitted": [],
    "values": {
      "tau": 0.5,
      "gamma": 2.0,
      "G_max": 1.3,
      "lambda_crit": 1.01
    }
  },
  {
    "id": "tabary_1972_shortened",
    "title": "Tabary 1972: shortened, then free",
    "source": "Source and doubts: tabary_1972_lengthened.csv. Removal is on: tau_rev like tau, and G_min below what was seen. File: examples/identification/published/tabary_1972_shortened.csv",
    "fitted": [],
    "values": {
      "tau": 0.5,
      "gamma": 2.0,
      "G_max": 1.3,
      "lambda_crit": 1.01,
      "tau_rev": 0.5,
      "gamma_rev": 2.0,
      "G_min": 0.4,
      "lambda_crit_rev": 1.0
    }
  },
  {
    "id": "csapo_2010",
    "title": "Csapo 2010: high heels",
    "source": "Csapo, Maganaris, Seynnes, Narici 2010, On muscle, tendon and high heels, J Exp Biol 213:2582. File: examples/identification/published/csapo_2010.csv",
    "fitted": [],
    "values": {
      "tau": 0.5,
      "gamma": 2.0,
      "G_max": 1.1,
      "lambda_crit": 1.01,
      "tau_rev": 0.5,
      "gamma_rev": 2.0,
      "G_min": 0.5,
      "lambda_crit_rev": 1.0
    }
  }
];
