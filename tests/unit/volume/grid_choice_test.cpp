// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/grid_choice.h>

#include "support/expect_error.h"

#include <string>
#include <vector>

namespace scrim {
namespace {

using test::errorOf;

const std::string kVector = "Tree_vec3s_5_4_3";
const std::string kInteger = "Tree_int32_5_4_3";

/// "place" or "place.component" of what is chosen, "none" where nothing is.
std::string chosen(const std::vector<GridOffer>& offers, const GridRequest& request) {
    const auto choice = chooseGrid(offers, request);
    if (!choice) return "none";
    std::string text = std::to_string(choice->grid);
    if (choice->component != GridRequest::kScalar) text += "." + std::to_string(choice->component);
    return text;
}

TEST(GridRequest, ComesBackFromItsText) {
    for (const GridRequest& request :
         {GridRequest{"density"}, GridRequest{""}, GridRequest{"Cd", 0}, GridRequest{"a:b[1]", 2}, GridRequest{"0:Cd"},
          GridRequest{"v", 0, GridPart::positive}, GridRequest{"*-0:v", 2, GridPart::places},
          GridRequest{"heat", GridRequest::kScalar, GridPart::ofPoints},
          GridRequest{"v", 1, GridPart::positiveOfPoints}, GridRequest{"v", 1, GridPart::negativeOfPoints}}) {
        EXPECT_EQ(gridRequestFrom(toText(request)), request) << toText(request);
    }
    EXPECT_EQ(toText(GridRequest{"density"}), "scalar:density");
    EXPECT_EQ(toText(GridRequest{"Cd", 0}), "0:Cd");
}

TEST(GridRequest, IsNotMadeOfAnyText) {
    for (const std::string text : {"", "density", "3:Cd", "--1:Cd", "-3:Cd", "+", "1"})
        EXPECT_EQ(errorOf(ErrorKind::usage, [&] { gridRequestFrom(text); }),
                  "'" + text + "' requests no grid; expected scalar:NAME, 0:NAME, 1:NAME or 2:NAME");
}

TEST(GridChoice, OfAColourPrefersAVectorThenThreeScalarsThenAGrey) {
    std::vector<GridOffer> offers{{"Cd"}, {"Cd.r"}, {"Cd.g"}, {"Cd.b"}, {"Cd.z"}, {"Cd.y"}, {"Cd.x"}, {"Cd", kVector}};
    EXPECT_EQ(chosen(offers, {"Cd", 1}), "7.1");
    offers.pop_back();
    EXPECT_EQ(chosen(offers, {"Cd", 0}), "6");
    EXPECT_EQ(chosen(offers, {"Cd", 1}), "5");
    EXPECT_EQ(chosen(offers, {"Cd", 2}), "4");
    offers.pop_back();  // without .x the others are no colour
    EXPECT_EQ(chosen(offers, {"Cd", 0}), "1");
    EXPECT_EQ(chosen(offers, {"Cd", 2}), "3");
    offers.erase(offers.begin() + 1);
    EXPECT_EQ(chosen(offers, {"Cd", 0}), "0");
    EXPECT_EQ(chosen(offers, {"Cd", 2}), "0");
    EXPECT_EQ(chosen({}, {"Cd", 2}), "none");
}

TEST(GridChoice, OfAColourIsTheFirstThatFitsAmongEqualNames) {
    const std::vector<GridOffer> offers{{"Cd", kInteger}, {"Cd", kVector}, {"Cd", "Tree_vec3d_5_4_3"}};
    EXPECT_EQ(chosen(offers, {"Cd", 0}), "1.0");
    EXPECT_EQ(chosen(offers, {"Cd[2]", 0}), "2.0");
    EXPECT_EQ(chosen(offers, {"Cd[0]", 0}), "none");
    EXPECT_EQ(chosen(offers, {"Cd"}), "0") << "a scalar";
}

TEST(GridChoice, SaysWhatThereIsInsteadOfAColour) {
    const std::vector<GridOffer> offers{{"id", kInteger}, {"density"}, {"v", kVector}, {"v", kVector}};
    EXPECT_EQ(whyNoGrid(offers, {"Cd", 0}),
              "no grid 'Cd'; it holds 'id' (int32), 'density' (float), 'v[0]' (vec3s), 'v[1]' (vec3s)");
    EXPECT_EQ(
        whyNoGrid(offers, {"id", 0}),
        "grid 'id' holds int32 values, where a colour is expected: a vec3 grid, three scalar ones called 'id.x', "
        "'id.y', 'id.z' or 'id.r', 'id.g', 'id.b', or a scalar one, which is grey; there is 'id' (int32), 'density' "
        "(float), 'v[0]' (vec3s), 'v[1]' (vec3s)");
    EXPECT_EQ(whyNoGrid({}, {"Cd", 0}), "no grid 'Cd'; it holds none");
}

TEST(GridChoice, OfAScalarTakesNumbersOfEveryKindButRealOnesFirst) {
    const std::vector<std::string> whole{"int32", "int64", "bool", "mask"};
    for (const std::string& type : whole) {
        const GridOffer offer{"id", "Tree_" + type + "_5_4_3", "fog volume"};
        EXPECT_EQ(chosen({offer}, {""}), "0") << type;
        EXPECT_EQ(chosen({offer}, {"id"}), "0") << type;
        EXPECT_EQ(chosen({offer, {"heat", GridOffer::kFloat, "level set"}}, {""}), "1") << type;
        EXPECT_EQ(chosen({{"heat"}, {"density", offer.type, ""}}, {""}), "1") << type;
        EXPECT_EQ(chosen({offer}, {"id", 0}), "none") << "a colour of " << type;
    }
    const GridOffer points{"p", GridOffer::kPoints, ""};
    EXPECT_EQ(chosen({points}, {"p"}), "0");
    EXPECT_EQ(chosen({points}, {""}), "0");
    EXPECT_EQ(chosen({points}, {"p", 0}), "none") << "points are no colour";
    EXPECT_EQ(chosen({points, {"id", "Tree_int32_5_4_3", ""}}, {""}), "1") << "points come last";
}

TEST(GridChoice, OfAScalarMayBeAComponentOfAVector) {
    const std::vector<GridOffer> offers{{"v", kVector}, {"v.y"}, {"density"}};
    EXPECT_EQ(chosen(offers, {"v.x"}), "0.0");
    EXPECT_EQ(chosen(offers, {"v.y"}), "1") << "a grid of that name";
    EXPECT_EQ(chosen(offers, {"v.b"}), "0.2");
    EXPECT_EQ(chosen(offers, {"v.a"}), "none");
    EXPECT_EQ(chosen(offers, {"density.x"}), "none");
    EXPECT_EQ(
        whyNoGrid(offers, {"v"}),
        "grid 'v' holds vec3s values, where a scalar grid is expected: 'v.x', 'v.y' and 'v.z' are its components; "
        "there is 'v' (vec3s), 'v.y' (float), 'density' (float)");
}

TEST(GridOffer, ShowsWhatItHoldsAsOpenVdbSpellsIt) {
    const std::vector<std::pair<std::string, std::string>> types{{"Tree_float_5_4_3", "float"},
                                                                 {"Tree_vec3s_5_4_3", "vec3s"},
                                                                 {"Tree_int32_5_4_3", "int32"},
                                                                 {"Tree_ptdataidx32_5_4_3", "ptdataidx32"},
                                                                 {"Tree_5_4_3", "5_4_3"},
                                                                 {"Tree_", ""},
                                                                 {"odd", "odd"}};
    for (const auto& [type, word] : types) EXPECT_EQ((GridOffer{"a", type, ""}.valueType()), word);
}

}  // namespace
}  // namespace scrim
