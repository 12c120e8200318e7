//! The words: of leaf, of wood, of what is neither, and of what says nothing. Blanks part them.

/// Leaf, as whole parts of a name. A twig is leaf: real files call their leaf cards so.
pub(super) const LEAF: &str = "
    leaf leaves leafs lf lvs foliage fol frond fronds needle needles twig twigs petal petals blade blades grass
    flower flowers blossom blossoms bloom sepal canopy crown leafcard leafcards leaflet leaflets ivy fern moss
    pinnule greenery
    blatt blaetter blätter laub nadel nadeln wedel zweig zweige gras bluete blüte blueten blüten halm halme
    laubwerk
    feuille feuilles feuillage aiguille aiguilles fleur fleurs herbe foglia foglie fogliame fiore fiori erba
    hoja hojas follaje flor flores hierba folha folhas folhagem petalo petali petalos pétale pétales
    blad bladeren naald naalden löv lov barr lisc liść liscie liście listi listí
    bloem bloemen bloesem blomma blommor kwiat kwiaty płatek płatki květ květy
";

/// Flowers, among the words of leaf: white ones are white.
pub(super) const FLOWERS: &str = "
    petal petals flower flowers blossom blossoms bloom sepal bluete blüte blueten blüten fleur fleurs fiore fiori flor
    flores petalo petali petalos pétale pétales bloem bloemen bloesem blomma blommor kwiat kwiaty płatek płatki květ
    květy
";

/// Words of [`FLOWERS`] that count at the start or end of a longer part.
pub(super) const FLOWERS_WITHIN: &str = "petal petals blüte blüten bluete blueten 花 цветок цветы лепест";

/// Words of leaf that are said of bare wood, too.
pub(super) const TWIGS: &str = "twig twigs zweig zweige";

/// Words of wood that are said of cards of leaves, too.
pub(super) const BRANCHES: &str = "
    branch branches bough boughs ast aeste äste branche ramo rami rama ramas galho galhos tak takken gren grenar gałąź
    vetev větev
";

/// Words beside `root` in names that exporters give to the first node of a file.
pub(super) const ROOTS: &str = "
    root node scene gltf fbx obj joint model object sketchfab armature rig skeleton group null empty dummy bone world
    transform parent main default tree plant
";

/// Wood, as whole parts of a name.
pub(super) const WOOD: &str = "
    bark trunk trunks branch branches bough boughs limb limbs stem stems stalk stalks wood log logs stump root
    roots cane canes culm petiole cambium brn trk cap caps
    rinde borke stamm staemme stämme ast aeste äste holz wurzel wurzeln stiel stängel staengel
    ecorce écorce tronc branche branches tige tiges bois racine racines corteccia tronco ramo rami legno gambo
    radice corteza rama ramas tallo madera casca galho galhos madeira caule
    schors boomstam tak takken stengel gren grenar kora kmen pien pień galaz gałąź vetev větev
";

/// Leaf words that count at the start or end of a longer part.
pub(super) const LEAF_WITHIN: &str = "
    leaf leaves foliage frond needle petal blatt blaetter blätter nadeln feuille 葉 叶 листь
    blüte blüten bluete blueten 花 цветок цветы лепест
";

/// Wood words that count at the start or end of a longer part. Not `wood` and `holz`, which end the
/// names of species (boxwood), nor `stem` (system).
pub(super) const WOOD_WITHIN: &str = "
    bark trunk branch stamm rinde 幹 枝 树皮 树干 树枝 樹皮 кора ветк ствол
";

/// Nouns of what is no plant, as whole parts of a name: what ends in one is neither leaf nor wood without being asked.
pub(super) const FOREIGN: &str = "
    pot pots flowerpot plantpot planter planters vase urn bucket tub tray bowl box crate basket container ground
    soil dirt mud earth terrain land sand gravel pebble pebbles mulch litter snow water rock rocks stone stones
    boulder cliff chip chips wall walls fence floor roof pavement path road street brick bricks concrete cement tile tiles
    metal iron steel plastic glass ceramic terracotta clay plinth pedestal stand table bench house building
    porcelain stoneware earthenware wicker saucer hangpot cachepot windowbox flowerbox compost substrate peat perlite
    helper dummy sky
    swing sign door lamp lantern axe shed cabin chair stool barrel gate cart wheel statue
    porzellan steingut kasten blumenkasten untersetzer kompost torf
    topf blumentopf kübel kuebel vasen boden erde erdreich stein steine fels felsen mauer wand zaun kies beton
    ziegel beet
    sol terre mur murs roche rocher pierre bac jardinière jardiniere vaso terra terreno suolo muro roccia pietra
    maceta tiesto suelo tierra roca piedra solo chão rocha pedra
    bloempot grond muur rots steen kruka jord mark sten doniczka ziemia skała skala kamień kamien květináč
    kvetinac země zeme zeď zed skála kámen
    花盆 盆 鉢 植木鉢 土 土壤 泥土 地面 石 岩石 墙
";

/// Nouns of [`FOREIGN`] that count at the end of a longer part: `Blumentopf`, `gardenwall`.
pub(super) const FOREIGN_WITHIN: &str = "
    topf kasten flowerpot plantpot planter ground boden stein stone wall mauer fence pflaster
";

/// Words of what engines keep beside a plant, wherever they stand in a name: shapes for collisions and for hiding, and
/// pictures of the whole plant. `UCX_trunk` is no trunk, and `leaves_billboard` are no leaves.
pub(super) const STAND_INS: &str = "
    ucx ubx ucp usp collision collisions collider colliders colonly convcol convcolonly hull hulls occluder occluders
    bounds proxy backdrop billboard billboards impostor impostors imposter imposters
";

/// Words of [`STAND_INS`] that count at the end of a longer part: `treecollider`.
pub(super) const STAND_INS_WITHIN: &str = "collider collision colonly occluder billboard impostor imposter";

/// What may follow a class word without changing what it says: words of exporters, sides, sizes, seasons, colours and
/// names of plants. `leaf_mat` and `leaf_oak` are leaf; a `leaf_tray` may be anything.
pub(super) const NEUTRAL: &str = "
    mat mats material materials mtl shader sh sg tex texture textures txt map maps atlas sheet diffuse diff dif
    albedo alb basecolor base color colors colour col opacity alpha mask masked cutout clip cut blend
    transparent transparency translucent translucency opaque sss normal normals nrm bump uv uvs lod lods level
    mesh meshes geo geom geometry model obj object objects node group grp part parts element instance inst copy
    dup new old final test default main master set slot id no nr num var variant variation version ver type
    style pbr bsdf principled phong blinn lambert surface hd sd hq lq res png jpg jpeg tga tif webp srgb linear
    raw import imported export baked bake poly lowpoly highpoly skin card cards plane planes quad quads
    shape curve nurbs
    front frontside back backside side sides top bottom upper lower under underside inner outer inside outside
    left right single double twosided doublesided sided one two three four a small smaller big bigger large
    medium med mid long short thin thick tall young adult mature fresh dead dry dried wilted broken bare autumn
    fall spring summer winter season low high tip tips end ends all only cluster clusters clump clumps bunch
    bunches tuft tufts patch spray crossed cross
    green red yellow orange brown white black grey gray dark light pink purple blue golden silver pale
    weiss weiß rot gelb rosa grün gruen blau braun blanc blanche rouge jaune vert verte blanco blanca rojo roja amarillo
    amarilla verde azul bianco bianca rosso rossa giallo gialla branco branca
    tree trees plant plants bush shrub hedge oak maple pine spruce fir birch beech elm willow poplar aspen
    cherry apple palm cedar larch alder linden lime chestnut walnut hazel rowan sycamore eucalyptus olive
    juniper cypress yew holly bamboo boxwood ficus banana tropical conifer quercus acer pinus picea abies betula
    fagus fraxinus ulmus salix populus prunus malus tilia larix alnus corylus juniperus cedrus eiche ahorn
    kiefer fichte tanne birke buche esche ulme weide pappel linde baum busch strauch pflanze
";

/// Plurals of class words: what follows one is no head of a compound, so they decide whatever follows.
pub(super) const PLURALS: &str = "
    leaves leafs lvs fronds needles twigs petals blades flowers blossoms leafcards leaflets foliage blaetter
    blätter nadeln zweige blueten blüten halme feuilles aiguilles fleurs foglie fiori hojas flores folhas petali
    petalos pétales bladeren naalden trunks branches boughs limbs stems stalks logs roots staemme stämme aeste
    äste wurzeln tiges racines rami ramas galhos takken grenar bark rinde borke
";

/// Leaf words that are no name of a kind of plant either, as `fern` and `blossom` are: beside a word of wood they mean
/// leaves.
pub(super) const LEAVES: &str = "
    leaf leaves leafs lf lvs foliage fol frond fronds needle needles blatt blaetter blätter laub laubwerk nadel nadeln
    feuille feuilles feuillage foglia foglie fogliame hoja hojas follaje folha folhas folhagem blad bladeren
";

/// Wood words that no leaf is a part of, as it is of a branch or a stem.
pub(super) const TRUNKS: &str = "
    bark trunk trunks rinde borke stamm staemme stämme ecorce écorce tronc tronco corteza corteccia casca schors
    boomstam
";

/// Words between two things that are both meant.
pub(super) const AND: &str = "and und et och";

/// Words of plants that may only say what a thing before them is covered with or made of: `Ground_grass` is ground, and
/// `table_wood` a table.
pub(super) const COVERS: &str = "
    grass moss flower flowers blossom blossoms bloom canopy crown wood log logs roots root
    gras moos bluete blüte blueten blüten holz wurzeln herbe mousse fleur fleurs bois racines erba muschio fiore fiori
    legno radici hierba musgo flor flores madera raices erva madeira
";

/// Words of an image in which several things have their places.
pub(super) const ATLASES: &str = "atlas atlases texatlas textureatlas trimsheet";

/// Words of what grows on bark, or on wood that lies: `bark_moss` may be a trunk with moss, or moss for a trunk.
pub(super) const GROWN: &str = "
    moss mosses lichen ivy fern ferns grass grasses flower flowers blossom blossoms leafy mossy
    moos flechte efeu farn farne gras bluete blüte blueten blüten mousse lierre fougere fougère lichens herbe fleur
    fleurs muschio edera felce erba fiore fiori musgo hiedra helecho hierba flor flores hera samambaia erva mos klimop
    varen
";

/// Words between a thing and what it is of, in languages that name the thing first: `pot_de_fleurs`.
pub(super) const OF: &str = "de du des di del della dei da do dos das of for von mit with con avec";
