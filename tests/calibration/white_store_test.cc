#include "calibration/gls/white_store.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <random>

#include "calibration/gls/scaled_ldlt.h"

namespace gyrobench::calibration {
namespace {

constexpr Eigen::Index kRows = 200, kColumns = 6;

class WhiteStoreTest : public ::testing::Test {
 protected:
  Eigen::MatrixXd Draw(Eigen::Index columns) {
    Eigen::MatrixXd out(kRows, columns);
    for (double& value : out.reshaped()) value = normal_(random_);
    return out;
  }

  std::mt19937 random_{3};
  std::normal_distribution<double> normal_;
  Eigen::VectorXd output_ = Draw(1);
  Eigen::MatrixXd columns_ = Draw(kColumns);
  WhiteStore store_{output_, kColumns};
};

// By orthogonal factors of the columns themselves, not by their products.
double ResidualSquare(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output) {
  return (output - columns * columns.colPivHouseholderQr().solve(output)).squaredNorm();
}

TEST_F(WhiteStoreTest, FitsEveryModelAsLeastSquaresOfItsColumnsDo) {
  store_.Add(columns_);
  for (const WhiteStore::Columns& model :
       {WhiteStore::Columns{0}, {5, 1}, {0, 1, 2, 3, 4, 5}, {4, 2, 0}}) {
    const Eigen::MatrixXd taken = store_.Take(model);
    EXPECT_EQ(taken, columns_(Eigen::all, model));
    const WhiteStore::Fit fit = store_.FitTo(model);
    EXPECT_EQ(fit.rank, static_cast<int>(model.size()));
    EXPECT_NEAR(fit.residual_square, ResidualSquare(taken, output_), 1e-9 * kRows);
    EXPECT_TRUE(store_.Solve(model).isApprox(taken.colPivHouseholderQr().solve(output_), 1e-9));
  }
}

TEST_F(WhiteStoreTest, GivesTheSameWhetherProductsAreMadeAheadOrWhenTheyAreAskedFor) {
  store_.Add(columns_);
  WhiteStore ahead(output_, kColumns);
  ahead.Add(columns_);
  ahead.MultiplyFirst(2);
  ahead.MultiplyEachOther({2, 3, 4});
  const WhiteStore::Columns model = {0, 1, 5}, others = {2, 3, 4};
  const WhiteStore::Remainder a = store_.RemainderOf(others, model);
  const WhiteStore::Remainder b = ahead.RemainderOf(others, model);
  EXPECT_TRUE(a.products.isApprox(b.products, 1e-12));
  EXPECT_TRUE(a.with_output.isApprox(b.with_output, 1e-12));
  for (const Eigen::Index column : others)
    EXPECT_NEAR(store_.Left(column, model), ahead.Left(column, model), 1e-12);
}

TEST_F(WhiteStoreTest, GivesSomeRowsOfItsColumnsAndTheirProductsOfAllRows) {
  store_.Add(columns_);
  const WhiteStore::Columns model = {4, 0, 3};
  EXPECT_EQ(store_.Take(model, 20, 50), columns_(Eigen::seqN(20, 50), model));
  const Eigen::MatrixXd taken = columns_(Eigen::all, model);
  EXPECT_TRUE(store_.Products(model).isApprox(taken.transpose() * taken, 1e-12));
}

TEST_F(WhiteStoreTest, KnowsNothingMoreOfColumnsThatWereTakenAway) {
  store_.Add(columns_.leftCols(2));
  const Eigen::Index mark = store_.used();
  const WhiteStore::Columns gone = store_.Add(columns_.middleCols(2, 1));
  store_.FitTo(std::vector<Eigen::Index>{0, 1, gone[0]});
  store_.DropFrom(mark);
  const WhiteStore::Columns there = store_.Add(columns_.middleCols(3, 1));
  ASSERT_EQ(there, gone);
  const WhiteStore::Columns model = {0, 1, there[0]};
  EXPECT_NEAR(store_.FitTo(model).residual_square,
              ResidualSquare(columns_(Eigen::all, {0, 1, 3}), output_), 1e-9 * kRows);
}

TEST_F(WhiteStoreTest, CountsADependentColumnOnceAndKeepsWhatItHasWhenItGrows) {
  store_.Add(columns_);
  const double before = store_.FitTo(std::vector<Eigen::Index>{0, 1}).residual_square;
  const WhiteStore::Columns sum = store_.Add(columns_.col(0) + 2.0 * columns_.col(1));
  const WhiteStore::Columns model = {0, 1, sum[0]};
  const WhiteStore::Fit fit = store_.FitTo(model);
  EXPECT_EQ(fit.rank, 2);
  EXPECT_DOUBLE_EQ(fit.residual_square, before);
  EXPECT_EQ(store_.Solve(model)(2), 0.0);
  EXPECT_LT(store_.Left(sum[0], std::vector<Eigen::Index>{0, 1}), 1e-9);
}

// What a model explains of an output is what orthogonal factors leave out of it.
TEST_F(WhiteStoreTest, SquaresOfManyOutputsAreWhatTheModelExplainsOfEach) {
  Eigen::MatrixXd columns = columns_;
  columns.col(2) *= 1e6;  // units differ
  const Eigen::MatrixXd outputs = Draw(5);
  const ScaledLdlt factor(columns.transpose() * columns);
  const Eigen::VectorXd squares = factor.Squares(columns.transpose() * outputs);
  for (Eigen::Index k = 0; k < outputs.cols(); ++k) {
    const Eigen::VectorXd output = outputs.col(k);
    EXPECT_NEAR(squares(k), output.squaredNorm() - ResidualSquare(columns, output),
                1e-9 * output.squaredNorm());
  }
}

}  // namespace
}  // namespace gyrobench::calibration
